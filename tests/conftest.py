import pytest


def pytest_addoption(parser):
    parser.addoption("--slow", action="store_true", help="also run the long studies")


def pytest_collection_modifyitems(config, items):
    if not config.getoption("--slow"):
        for item in items:
            if "slow" in item.keywords:
                item.add_marker(pytest.mark.skip(reason="long study: add --slow"))
