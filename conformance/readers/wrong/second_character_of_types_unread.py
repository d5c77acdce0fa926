#!/usr/bin/python3 -IS
# caught by: invalid/C1-type-wrong-in-the-second-of-small-letters
"""Does not look at the second character of a type (C1)."""
import sys

sys.path.insert(0, __file__.rpartition("/")[0] + "/..")
from edited import reader_with

reader = reader_with(("[A-Z][A-Z0-9]{3}|[a-z][A-Za-z0-9]{3}",
                      "(?s:[A-Z].[A-Z0-9]{2}|[a-z].[A-Za-z0-9]{2})"))

sys.exit(reader.main(sys.argv[1:]))
