"""`python -m vibrocap` is the command line."""

import sys

from vibrocap.cli.main import main

sys.exit(main())
