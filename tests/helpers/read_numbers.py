"""Numbers read back from what people read."""

import re


def numbers_in(text: str) -> list[float]:
    found = re.findall(r"(−?[\d,]*\.?\d+)(?:·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?", text)
    powers = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    return [
        float(number.replace("−", "-").replace(",", "")) * 10.0 ** int(power.translate(powers) or 0)
        for number, power in found
    ]
