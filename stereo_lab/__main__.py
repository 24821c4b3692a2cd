"""``python -m stereo_lab`` is ``stereo-lab``."""

import sys

try:
    from stereo_lab.cli import main
except KeyboardInterrupt:  # Ctrl-C before anything has begun
    sys.exit(130)

sys.exit(main())
