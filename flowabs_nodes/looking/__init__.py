"""Make pictures to look at of images of any type: a flow as colour, a depth from near to far, an id as a colour."""
