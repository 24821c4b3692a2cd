"""Every figure. Plot functions take ``ax=None``, return ``ax`` and compute nothing.

Colours are those of Okabe and Ito; marker and dash tell the same story to whoever sees no colour.
"""

from stereo_lab.plots.base import *  # noqa: F403
from stereo_lab.plots.lesson00 import *  # noqa: F403
from stereo_lab.plots.lesson01 import *  # noqa: F403
from stereo_lab.plots.lesson02 import *  # noqa: F403
from stereo_lab.plots.lesson03 import *  # noqa: F403
from stereo_lab.plots.lesson04 import *  # noqa: F403
from stereo_lab.plots.lesson05 import *  # noqa: F403
from stereo_lab.plots.lesson06 import *  # noqa: F403
from stereo_lab.plots.lesson07 import *  # noqa: F403
from stereo_lab.plots.lesson08 import *  # noqa: F403
from stereo_lab.plots.lesson09 import *  # noqa: F403
from stereo_lab.plots.sheets import *  # noqa: F403
from stereo_lab.plots.solid import *  # noqa: F403
