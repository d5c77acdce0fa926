#!/usr/bin/python3 -IS
# caught by: valid/layer-of-a-pose-as-far-back-as-can-be
"""Lets a POSE move one of the last 16 LAYRs alone, however many bodies there are (K6)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("deque(maxlen=16 * len(bodies))",
                      "deque(maxlen=16)"))

sys.exit(reader.main(sys.argv[1:]))
