import threading
import urllib.error
import urllib.request

import pytest

from plant_bench.errors import InputError
from plant_bench.reports.replay.file_server import address_of, file_server


def test_files_are_served_locally_and_not_above_the_folder(tmp_path):
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "replay.html").write_text("hello")
    (tmp_path / "secret").write_text("no")
    with file_server(tmp_path / "site", 0) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        address = address_of(server, tmp_path / "site")
        assert address.startswith("http://127.0.0.1:")
        with urllib.request.urlopen(address) as answer:
            assert answer.read() == b"hello"
        with pytest.raises(urllib.error.HTTPError):
            urllib.request.urlopen(address.replace("replay.html", "%2e%2e/secret"))
        server.shutdown()
        thread.join()


def test_busy_port_is_refused_with_one_message(tmp_path):
    with (
        file_server(tmp_path, 0) as server,
        pytest.raises(InputError, match=r"Port \d+ is in use. Choose another with --port"),
    ):
        file_server(tmp_path, server.server_address[1])


def test_missing_folder_is_refused(tmp_path):
    with pytest.raises(InputError, match="There is no folder"):
        file_server(tmp_path / "nowhere", 0)
