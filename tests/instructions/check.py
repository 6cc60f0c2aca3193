#!/usr/bin/python3
"""check.py FILE: disassembles it and fails on an instruction that is not in x86-64-v2.

Those of x86-64-v3 are AVX, FMA and F16C (all of them start with v), BMI, LZCNT and MOVBE. TZCNT
passes: it is what objdump calls `rep bsf`, which g++ writes for every machine and older ones run
as BSF.
"""
import re
import subprocess
import sys
from collections import Counter

V3 = re.compile(r"v\w+|lzcnt|movbe|andn|bextr|bls(i|r|msk)|bzhi|mulx|p(dep|ext)|rorx|s(ar|hl|hr)x")
FUNCTION = re.compile(r"[0-9a-f]+ <(.*)>:$")


def main():
    listing = subprocess.Popen(
        ["objdump", "--disassemble", "--no-show-raw-insn", "--demangle", sys.argv[1]],
        stdout=subprocess.PIPE, text=True)
    instructions = 0
    function = ""
    found = Counter()
    for line in listing.stdout:
        if not line.startswith(" "):
            start = FUNCTION.match(line)
            function = start.group(1) if start else function
            continue
        instructions += 1
        mnemonic = line.split("\t")[1].split()[0]
        found[(mnemonic, function)] += bool(V3.fullmatch(mnemonic))
    found = +found
    for (mnemonic, function), count in found.most_common(20):
        print(f"{mnemonic} x{count} in {function}")
    print(f"{instructions} instructions, {sum(found.values())} of them not in x86-64-v2")
    return 1 if listing.wait() or instructions == 0 or found else 0


if __name__ == "__main__":
    sys.exit(main())
