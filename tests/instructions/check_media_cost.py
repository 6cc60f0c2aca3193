#!/usr/bin/python3
"""check_media_cost.py MEDIA_COST [BAR]: instructions of the gray instance over those of the general
one, by callgrind.

Instructions per look-up and leaf (per look-up in one leaf), as the difference of two runs, which
takes the set-up out of them, less what drawing the test's rays takes. The tracker by itself, in one
leaf, has to be at most BAR (0.6), and so have first flights of rays where they are look-ups, beside the
general instance in a medium that needs all of it (0.7 beside the same instance in the gray medium); the
rest less than 1: octree walk, trilinear look-ups, shadow rays and new directions are the same code for
both (docs/decisions.md). Given a BAR, only the tracker is looked at. 77, which ctest takes for
"skipped", where there is no valgrind.
"""
import re
import shutil
import subprocess
import sys
import tempfile

FEW, MANY = 100, 600


def run(program, number, *arguments):
    """Instructions; look-ups and leaves together."""
    what, instance, depth = arguments
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out", program,
             what, instance, str(number), depth], capture_output=True, text=True, check=True)
    lookups, leaves = map(float, re.findall(r"([\d.]+) (?:lookups|leaves)", done.stdout))
    counted = lookups if what == "leaf" else lookups + leaves
    return int(re.search(r"Collected : (\d+)", done.stderr).group(1)), counted * number


def price(program, what, instance, depth, per_ray):
    few, few_counted = run(program, FEW, what, instance, depth)
    many, many_counted = run(program, MANY, what, instance, depth)
    rays = 0 if what == "leaf" else per_ray * (MANY - FEW)
    return (many - few - rays) / (many_counted - few_counted)


def price_of_rays(program):
    return (run(program, MANY, "rays", "gray", "1")[0] -
            run(program, FEW, "rays", "gray", "1")[0]) / (MANY - FEW)


def main():
    if not shutil.which("valgrind"):
        print("no valgrind here")
        return 77
    program = sys.argv[1]
    tracker_alone = len(sys.argv) > 2
    bar = float(sys.argv[2]) if tracker_alone else 0.6
    failed = False
    per_ray = price_of_rays(program)
    for what, depth, bars in [("leaf", "1", {"general": bar})] if tracker_alone else [
            ("leaf", "1", {"general": bar}),
            ("flights", "1", {"general": 0.7, "full": 0.6}),
            ("flights", "6", {"general": 1.0, "full": 1.0}),
            ("paths", "1", {"general": 1.0, "full": 1.0}),
            ("paths", "6", {"general": 1.0, "full": 1.0})]:
        gray = price(program, what, "gray", depth, per_ray)
        for instance, most in bars.items():
            other = price(program, what, instance, depth, per_ray)
            verdict = "" if gray / other <= most else " FAILED"
            failed |= bool(verdict)
            print(f"{what}, depth {depth}: gray {gray:.0f}, {instance} {other:.0f}, "
                  f"ratio {gray / other:.2f}, at most {most}{verdict}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
