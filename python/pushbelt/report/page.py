"""Common parts of the reports: number formats, templates, the embedded library of the figures."""

import base64
import functools
import gzip
import platform
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from .. import provenance
from . import style

MINUS = "\N{MINUS SIGN}"


class Check(NamedTuple):
    """A statement about results, and whether they confirm it."""

    statement: str
    passed: bool
    found: str


def number(value: float, digits: int = 0) -> str:
    """A number with fixed decimals, thin spaces between thousands and a typographic minus sign."""
    text = f"{value:,.{digits}f}".replace(",", "\N{NARROW NO-BREAK SPACE}")
    negative_zero = float(f"{value:.{digits}f}") == 0.0
    return text.removeprefix("-") if negative_zero else text.replace("-", MINUS)


def percent(value: float, digits: int = 1) -> str:
    """A share in per cent, without the per cent sign."""
    return number(100.0 * value, digits)


def short(value: float) -> str:
    """A number with four digits, a large one without decimals."""
    return (f"{value:.0f}" if 9999.5 <= abs(value) < 1e7 else f"{value:.4g}").replace("-", MINUS)


@functools.cache
def _environment(folder: Path | None = None, **filters: Any) -> jinja2.Environment:
    here = Path(__file__).parent
    loader = jinja2.FileSystemLoader([*([folder] if folder else []), here.parent, here])
    options: dict[str, Any] = {"autoescape": True, "undefined": jinja2.StrictUndefined, "trim_blocks": True, "lstrip_blocks": True}
    environment = jinja2.Environment(loader=loader, **options)
    environment.filters.update({"number": number, "percent": percent, "short": short, **filters})
    return environment


def fragment(template: str, **values: Any) -> Markup:
    """A part of a page from a template of this folder."""
    return Markup(_environment().get_template(template).render(values))


def write_html(template: str, context: Mapping[str, Any], path: Path, folder: Path | None = None, **filters: Any) -> Path:
    """Writes a page from a template, and returns its path; a missing folder is made. `template` is its path inside this package, or inside
    `folder`, and begins with the program's name."""
    machine = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"
    origin = provenance.current(re.split("[/.]", template)[0])
    text = _environment(folder, **filters).get_template(template).render(context, machine=machine, origin=origin)
    if 'class="chart"' in text or 'class="belt"' in text:
        colours = {"ink": style.INK, "muted": style.MUTED, "grid": style.GRID}
        scripts = fragment("scripts.html.j2", **colours, plotly=packed_plotly(), notices=plotly_notices())
        text = text.replace("</main>", f"{scripts}</main>")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


@functools.cache
def packed_plotly() -> str:
    """The library of the figures for embedding in a page, compressed to a third. Compression also hides its web addresses from searches."""
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), mtime=0)).decode()


def plotly_notices() -> str:
    """Licence notices of the library and its parts."""
    script = get_plotlyjs()
    parts = script[script.rindex("/*! Bundled license information:") :]
    return script[: script.index("*/")].strip("/* \n") + "\n\n" + parts[3 : parts.index("\n*/")]
