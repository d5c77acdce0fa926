#!/usr/bin/python3 -IS
# caught by: valid/attributes-of-means-with-components
"""Means inherit the mean of the first number of a row for all numbers of binary32."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("else each / len(sources) for each in sums]",
                      "else each / len(sources) for each in (sums[:1] * components if kind == F32 else sums)]"))

sys.exit(reader.main(sys.argv[1:]))
