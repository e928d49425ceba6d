import pytest

from fascicle.cli import main


@pytest.fixture
def fascicle(capsys, monkeypatch, tmp_path):
    """Run a command in an empty folder: exit code, standard output, standard error."""
    monkeypatch.setenv("FASCICLE_NO_CACHE", "1")
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        with pytest.raises(SystemExit) as end:
            main([str(argument) for argument in arguments])
        printed = capsys.readouterr()
        return end.value.code, printed.out, printed.err

    return run


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Of a test of pages that fails: what is seen on each."""
    report = yield
    if report.failed and call.when == "call":
        for page in getattr(item.funcargs.get("visit"), "pages", ()):
            try:
                shown = page.locator("body").aria_snapshot(timeout=5_000)
            except Exception as error:  # noqa: BLE001 the test has failed of something else
                shown = error
            report.sections.append((page.url, str(shown)))
    return report
