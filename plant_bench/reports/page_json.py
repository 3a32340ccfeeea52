"""Values as JSON that may stand inside a page, whatever texts of others they hold."""

import json

_UNSAFE = {"<": "\\u003c", ">": "\\u003e", "&": "\\u0026"}  # of ASCII; the rest is escaped anyway


def script_json(value: object) -> str:
    """Return a value as JSON that may stand in any script or page, whatever its texts are.

    Raises:
        ValueError: It holds NaN or infinity.
    """
    text = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    for character, escape in _UNSAFE.items():
        text = text.replace(character, escape)
    return text
