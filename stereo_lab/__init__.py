"""stereo_lab: see in 3D with two cheap webcams, and drive a robot arm to what they see.

A room is a module, or a folder of the same name. One lesson, one room, one notebook, one name:

=======  =====================  ==========================================================
lesson   room                   what is in it
=======  =====================  ==========================================================
01       ``calibration``        from chessboards to two calibrated cameras
02       ``detection``          the ball in one picture: the paper's way, and the cone
03       ``position``           x and y: two straight lines, or a rigid fit
04       ``depth``              depth from disparity: three models
05       ``kinematics``         joint angles of a two-link arm
06       ``motion``, ``arm``    motors, ways to stop them, and the arm behind a serial line
07       ``localization``,      all of it together: two pictures in, millimetres out;
         ``live``               again and again, with the arm behind the ball
08       ``capture``,           boards to print, a recorder, other people's files;
         ``doctor``             what is wrong with a recording, in plain words
09       ``detection``          how the judge's weights are learned; a ball of one's own
=======  =====================  ==========================================================

``recording`` opens the pictures that the lessons work on; ``results`` judges the chain; ``exercises`` asks the questions;
``plots`` and ``widgets`` draw; ``cli`` is the command ``stereo-lab``; ``firmware`` is the sketch of the real arm. Everybody
stands on ``common`` and ``errors``. Rooms import downwards only, and lessons never each other.
"""

__version__ = "0.4.0"
