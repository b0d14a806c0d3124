"""brep_slicer: laser metal deposition on shafts, planned on the exact B-Rep."""
