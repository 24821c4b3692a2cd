"""stereo_lab: see in 3D with two cheap webcams, and drive a robot arm to what they see.

One lesson, one module, one name:

=======  =====================  ==========================================================
lesson   module                 what is in it
=======  =====================  ==========================================================
01       ``calibration``        from chessboards to two calibrated cameras
02       ``detection``          the ball in one picture: the paper's way, and the cone
03       ``position``           x and y: two straight lines, or a rigid fit
04       ``depth``              depth from disparity: three models
05       ``kinematics``         joint angles of a two-link arm
06       ``motion``, ``arm``    motors, ways to stop them, and the arm behind a serial line
07       ``localization``       all of it together: two pictures in, millimetres out
=======  =====================  ==========================================================

``recording`` opens the pictures that the lessons work on, ``errors`` holds what can go wrong. ``homography`` (01) and
``hough`` (02) are written out to be read; ``exercises`` asks the questions, ``plots`` and ``widgets`` draw.
"""

__version__ = "0.3.0"
