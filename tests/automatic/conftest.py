from tests.report.conftest import halved_once  # noqa: F401 - pages of the same strokes here as well
