"""Detectors: they find when heel and toe of each foot are planted.

`footfix.detect(clip, rig)` is `footfix.api.clips.detect`; this package has the detectors.
"""
