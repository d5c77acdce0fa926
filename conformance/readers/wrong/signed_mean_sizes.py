#!/usr/bin/python3 -IS
# caught by: invalid/N6-sizes-of-type-6
"""Takes sizes of means of signed integers (N6)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(('sizes = Array(chunk, features, "N6", (U32,), 1)',
                      'sizes = Array(chunk, features, "N6", (U32, S32), 1)'))

sys.exit(reader.main(sys.argv[1:]))
