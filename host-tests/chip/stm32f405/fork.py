"""Work in a process that is forked from this one: what it does to a chip is gone with it."""

import os
import pickle


def in_a_fork(work):
    """What the work returns; an exception of it is raised here."""
    return begun(work)()


def begun(work):
    """Begins the work; the outcome is had by a call of what this returns."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        try:
            outcome = True, work()
        except BaseException as error:
            outcome = False, repr(error)
        with os.fdopen(writing, "wb") as pipe:
            pickle.dump(outcome, pipe)
        os._exit(0)
    os.close(writing)

    def outcome():
        with os.fdopen(reading, "rb") as pipe:
            data = pipe.read()
        os.waitpid(child, 0)
        if not data:
            raise RuntimeError("the process has ended without an answer")
        is_done, value = pickle.loads(data)
        if not is_done:
            raise RuntimeError(value)
        return value

    return outcome
