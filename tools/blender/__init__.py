"""Run the tests of ``plugins/blender`` in each Blender that is supported."""
