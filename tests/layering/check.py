#!/usr/bin/python3
"""Checks the structure of the sources: check.py [ROOT]

- An include in renderer/ or server/ that layers.txt does not allow or does not know.
- A header without #pragma once, a tab, a mark of unfinished work, a file of over 500 lines
  (a warning from 400 on).

Prints FILE:LINE: what is wrong, and exits with 1 if anything is.
"""
import re
import sys
from pathlib import Path

MAX_LINES = 500
WARN_LINES = 400
CODE = {".h", ".cpp", ".py", ""}  # scripts have no suffix
TEXT = CODE | {".txt", ".cmake"}
UNFINISHED = re.compile(r"\b(TO" r"DO|FIX" r"ME|XX" r"X|HA" r"CK)\b")  # split: this file is checked too
INCLUDE = re.compile(r'\s*#\s*include\s*(["<])([^">]+)[">]')


def read_layers(path):
    """What each layer may include: itself and the transitive closure of its arrows."""
    arrows = {}
    for line in path.read_text().splitlines():
        line = line.split("#")[0].strip()
        if line:
            source, targets = line.split("->")
            arrows[source.strip()] = targets.split()
    layers = set(arrows) | {target for targets in arrows.values() for target in targets}

    def reach(layer, above):
        if layer in above:
            sys.exit(f"{path}: circle through {layer}")
        below = [reach(target, above | {layer}) for target in arrows.get(layer, [])]
        return {layer}.union(*below)

    return {layer: reach(layer, frozenset()) for layer in layers}


def layer_of(parts):
    """The folder of a path rooted at renderer/ or server/; the stem of a file beside the folders."""
    return parts[0] if len(parts) > 1 else Path(parts[0]).stem


def check_include(layers, layer, bracket, included):
    """What is wrong with an include in a file of that layer, or None."""
    target = layer_of(included.split("/"))
    if bracket == "<" and ("/" not in included or target not in layers):
        return None  # a library's
    if target not in layers:
        return f'"{included}": {target} is not in layers.txt'
    if target not in layers[layer]:
        return f'"{included}": {layer} may not include {target}'
    return None


def sources(root, *tops):
    for top in tops:
        for path in sorted((root / top).rglob("*")):
            if path.suffix in TEXT and path.is_file() and "corpus" not in path.parts:
                yield path


def check_file(path):
    """(line, what is wrong) of the rules for every file."""
    lines = path.read_text().splitlines()
    if path.suffix == ".h" and "#pragma once" not in lines:
        yield 1, "no #pragma once"
    if path.suffix in CODE and len(lines) > MAX_LINES:
        yield len(lines), f"{len(lines)} lines; at most {MAX_LINES}"
    elif path.suffix in CODE and len(lines) > WARN_LINES:
        print(f"warning: {path}: {len(lines)} lines")
    for number, line in enumerate(lines, 1):
        if "\t" in line:
            yield number, "a tab"
        if UNFINISHED.search(line):
            yield number, "a mark of unfinished work"


def check_layers(root, layers):
    """(path, line, what is wrong) of every include in renderer/ and server/."""
    for path in sources(root, "renderer", "server"):
        if path.suffix not in {".h", ".cpp"}:
            continue
        layer = layer_of(path.relative_to(root).parts[1:])
        if layer not in layers:
            yield path, 1, f"{layer} is not in layers.txt"
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            include = INCLUDE.match(line)
            wrong = include and check_include(layers, layer, *include.groups())
            if wrong:
                yield path, number, wrong


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2]).resolve()
    layers = read_layers(Path(__file__).with_name("layers.txt"))
    wrong = list(check_layers(root, layers))
    files = list(sources(root, "renderer", "server", "tests", "scripts", ".ci"))
    wrong += [(path, *fault) for path in files for fault in check_file(path)]
    for path, number, what in wrong:
        print(f"{path.relative_to(root)}:{number}: {what}")
    print(f"{len(files)} files, {len(wrong)} faults")
    return 1 if wrong or not files else 0


if __name__ == "__main__":
    sys.exit(main())
