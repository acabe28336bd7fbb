"""`python -m vibrocap` is the command line."""

import sys

from vibrocap.faces.cli import main

sys.exit(main())
