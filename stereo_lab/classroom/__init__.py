"""The classroom: what a class hands in is run and marked, each notebook by itself.

``papers`` reads what was handed in, ``room`` shuts a notebook in, ``desk`` runs it in there. Outside, ``line`` holds the line to it,
``hearing`` judges what comes through, ``examiner`` runs it again where one run does not tell. ``marks``, ``table`` and ``page`` are
what comes out, ``store`` is what is finished, ``grading`` puts it together.
"""
