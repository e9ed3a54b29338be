"""Text to HTML: escaping, and the type that ASCII lacks."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Sequence

# After a number, in a label ("/ um"), in brackets, or alone in a column of units.
_MICRO = re.compile(r"(?:(?<=\d )|(?<=/ )|(?<=\()|^)u(?=(?:m|rad|s|N|A|V)\b)")
_TOGETHER = re.compile(r"(?<=\d) (?=(?:[%A-Za-zµΩ]))")


def escape(text: object) -> str:
    """Text that came from elsewhere (file names, notes): escaped, otherwise as it is."""
    printable = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in str(text))
    return html.escape(printable)


def typeset(text: str) -> str:
    """Our own text with ASCII units: micro and ohm signs, raised twos, no break before a unit."""
    text = _MICRO.sub("µ", text)
    text = re.sub(r"\bmohm\b", "mΩ", text)
    text = re.sub(r"\bohm\b", "Ω", text)
    text = re.sub(
        r"(?<=\d)e(-?)(\d+)\b", lambda m: f" × 10{_raised(m[1] + m[2].lstrip('0'))}", text
    )
    text = text.replace("^2", "²").replace(" x floor", "\N{NO-BREAK SPACE}×\N{NO-BREAK SPACE}floor")
    text = _TOGETHER.sub("\N{NO-BREAK SPACE}", text)
    text = re.sub(r"(?<![\w.])-(?=\d)", "\N{MINUS SIGN}", text)
    return html.escape(text)


def _raised(exponent: str) -> str:
    return exponent.translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def table(caption: str, head: Sequence[tuple[str, str]], rows: Iterable[Sequence[str]]) -> str:
    """A table of cells that are HTML already, below its caption (plain text).

    head: (heading as HTML, CSS class of the column). The first column names its row.
    """
    # The caption stands outside: a wide table scrolls on a phone, its caption should not.
    lines = [f'<p class="caption">{typeset(caption)}</p>' if caption else ""]
    lines.append('<div class="scroll"><table><thead><tr>')
    lines += [f'<th scope="col" class="{kind}">{name}</th>' for name, kind in head]
    lines.append("</tr></thead><tbody>")
    for row in rows:
        lines.append("<tr>")
        for column, (cell, (_, kind)) in enumerate(zip(row, head, strict=True)):
            tag = "th" if column == 0 else "td"
            scope = ' scope="row"' if column == 0 else ""
            lines.append(f'<{tag}{scope} class="{kind}">{cell}</{tag}>')
        lines.append("</tr>")
    lines.append("</tbody></table></div>")
    return "".join(lines)


def figure(picture: str, caption: str) -> str:
    """A picture above its caption (HTML)."""
    return f"<figure>{picture}<figcaption>{caption}</figcaption></figure>"


def key(*kinds: tuple[str, str]) -> str:
    """A legend: (CSS class of the curve, its name as HTML) each."""
    parts = [
        f'<span class="key"><svg class="swatch" viewBox="0 0 22 8" aria-hidden="true">'
        f'<path class="curve {kind}" d="M0 4H22"/></svg>{name}</span>'
        for kind, name in kinds
    ]
    return f'<p class="keys">{"".join(parts)}</p>'
