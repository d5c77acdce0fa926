#!/usr/bin/python3 -IS
# caught by: invalid/S7-copy-of-pose-and-layer
"""Takes a POSE with the same header for a copy, as of a LAYR (S7)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(('headers.get(lower, b"")[:4] == b"LAYR"',
                      'headers.get(lower, b"")[:4] in (b"LAYR", b"POSE")'))

sys.exit(reader.main(sys.argv[1:]))
