"""Goes on doing to runs what is done to them on a farm, hundreds of times; the tests do each ten times."""
