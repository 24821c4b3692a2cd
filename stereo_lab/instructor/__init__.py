"""What a teacher makes of the course for other programs: assignments for nbgrader."""

from stereo_lab.instructor.assignments import assignment, export_nbgrader

__all__ = ["assignment", "export_nbgrader"]
