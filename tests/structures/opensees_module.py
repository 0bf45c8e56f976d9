"""OpenSees for the scripts beside this file, which run in processes of their own: its wheel and its package differ in name."""

import importlib


def opensees():
    for name in ("openseespylinux.opensees", "openseespy.opensees"):
        try:
            return importlib.import_module(name)
        except (ImportError, RuntimeError):
            continue
    raise ImportError("OpenSees cannot be loaded")
