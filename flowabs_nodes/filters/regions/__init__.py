"""Region smoothing and flattening (section 4): FBL, bilateral filters, mean shift, quantisation."""
