"""``python -m stereo_lab`` is ``stereo-lab``."""

import sys

from stereo_lab.cli import main

sys.exit(main())
