"""Networks that netconvert makes of broken maps."""

import pytest

from plant_bench.errors import InputError
from plant_bench.towns.importing import mending
from plant_bench.towns.importing.converting import Converted
from plant_bench.towns.importing.source import MapKind, MapSource

UNESCAPED = '<net><tlLogic id="a" programID="<unknown>"/></net>'  # so netconvert writes it


@pytest.mark.parametrize("net", [UNESCAPED, "", "<net><edge><lane/></edge></net>"])
def test_a_network_that_cannot_be_read_is_refused(monkeypatch, net):
    monkeypatch.setattr(mending, "convert_source", lambda *_, **__: Converted(net, ()))
    source = MapSource("map.xml", MapKind.SUMO, b"", {})

    with pytest.raises(InputError, match="a network of map.xml that cannot be read"):
        mending.mend(source, "test", guess_signals=False, say=lambda _: None)
