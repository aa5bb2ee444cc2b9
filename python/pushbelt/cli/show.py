"""`pushbelt variables`, `pushbelt docs` and `pushbelt cache`."""

from __future__ import annotations

import argparse

from ..errors import ArgumentError, similar


def show_cache(options: argparse.Namespace) -> int:
    from ..fmu import cache

    folder = cache.folder()
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) if folder.is_dir() else 0
    if options.clear:
        cache.clear()
        print(f"removed {folder} ({size / 1e6:.1f} MB)")
    else:
        print(f"{folder} ({size / 1e6:.1f} MB)")
    return 0


def show_variables(options: argparse.Namespace) -> int:
    from ..fmu.files import default_fmu
    from ..fmu.untrusted import described
    from ..fmu.variables import Variables

    words = [word.lower() for word in options.words]
    variables = Variables(described(options.fmu or default_fmu()).modelVariables)
    fields = "profile." in " ".join(words)
    found = [
        one
        for one in variables.values()
        if (options.kind is None or one.causality == options.kind)
        and all(word in f"{one.name} {one.description}".lower() for word in words)
        and (fields or not one.name.startswith(("profile.", "profile_")))
    ]
    if not found:
        wanted = " ".join(options.words)
        raise ArgumentError(
            f"no {options.kind or 'variable'} has {' and '.join(options.words)} in its name or description{similar(wanted, variables)}"
        )
    for one in found:
        print(f"{one.name}\n    {', '.join([one.causality, *one.facts])}\n    {one.description}")
    print(f"{len(found)} of {len(variables)} variables" + ("" if fields else "; `pushbelt variables profile.` lists the fields"))
    return 0


def show_docs(options: argparse.Namespace) -> int:
    from ..fmu.files import DOCS

    # Pages that consist of a file of the source tree are left out.
    texts = {path.stem: path.read_text(encoding="utf-8") for path in DOCS.glob("*.md")}
    pages = sorted(name for name, text in texts.items() if "{{#include ../" not in text and name != "SUMMARY")
    if options.page is None:
        print(f"{DOCS}: {', '.join(pages)}\n`pushbelt docs PAGE` prints a page.")
        return 0
    name = options.page.removesuffix(".md")
    if name not in pages:
        raise ArgumentError(f"no page {name}{similar(name, pages) or '; there are ' + ', '.join(pages)}")
    print(texts[name])
    return 0
