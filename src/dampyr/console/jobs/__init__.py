"""Jobs, which take longer than a request: one file per kind, with ``run(request, folder, progress)``.

``request`` is the page's request, as JSON; ``folder`` is the job's own, for files; ``progress(stage, fraction done)`` reports
progress. ``run`` reads the data that the request names, calls one public function, writes its page, and returns the result,
a dictionary. Errors for people are raised as everywhere.
"""

MEMBERS = "kinds of jobs"

DATA = "data"  # of a result: the ``as_dict()`` of the job's result, which the command prints with --json
CARD, PAGE, CURVES = "card.toml", "page.html", "curves.json"  # what jobs leave in their folders
FIGURES, FILES = "figures", "files"  # folders of a job: the figures of its page, and what a command writes
