def doubts_of(axis, tests, before, found):
    return ()
