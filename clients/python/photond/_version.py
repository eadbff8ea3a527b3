__version__ = "0.1.0"  # the daemon's; tests/service/python_client_package_test.py holds the two together
