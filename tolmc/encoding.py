"""The text of a file that people wrote with any editor: UTF-8, or what its byte order mark says."""

from __future__ import annotations

import codecs

# UTF-32's little-endian mark begins with UTF-16's.
_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF32_LE: "utf-32",
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}


def decoded(content: bytes) -> str:
    """The text without its byte order mark; ValueError where it is in another encoding, with the remedy."""
    encoding = next((name for mark, name in _MARKS.items() if content.startswith(mark)), "utf-8")
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        raise ValueError(f"no text in {encoding.upper()} (byte {error.start}): save it as UTF-8") from None
    if text.count("\0") > len(text) // 4:
        raise ValueError("zeros between its characters, as UTF-16 without a byte order mark has: save it as UTF-8")
    return text
