#!/usr/bin/python3 -IS
# caught by: invalid
"""Reads nothing and finds nothing wrong."""
import sys

if sys.argv[1:] == ["--serve"]:
    for _ in sys.stdin:
        print("accept {}", flush=True)
else:
    print("{}")
