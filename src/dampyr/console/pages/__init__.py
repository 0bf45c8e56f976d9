"""The pages of the console, one file each, found by their names.

``pages/NAME.py`` has

- ``TITLE``, which stands in the navigation, and ``ORDER``, a number that says where;
- ``router``, a `fastapi.APIRouter`, whose paths come below ``/api/NAME``; an endpoint that takes ``app: CurrentApp``
  (:mod:`dampyr.console.state`) gets the data folder and the jobs;
- if it wants, ``lifespan(app_state)``, an async context manager that is entered when the console starts and left when it stops;
- if it wants, ``OPEN_HERE``, paths that need no token from this machine itself.

``static/pages/NAME.js`` exports ``show(root, query)``, which fills an empty element and may return a function that cleans up.
"""

MEMBERS = "pages of the console"
