"""Work that takes longer than a request: one file per kind, with ``run(request, folder, progress)``.

``request`` is what the page asked for, as JSON; ``folder`` is the job's own, for files; ``progress(stage, fraction done)``
tells how far it is. What ``run`` returns, a dictionary, is the result. Errors for people are raised as everywhere.
"""

MEMBERS = "kinds of work"

CARD, PAGE, CURVES = "card.toml", "page.html", "curves.json"  # what jobs leave in their folders
