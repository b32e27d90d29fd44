"""What other Python threads get to do while a call runs."""

import threading
import time


def ticks_during(function):
    """How often this thread wakes up from a sleep of a millisecond while another runs the function."""
    worker = threading.Thread(target=function)
    worker.start()
    ticks = 0
    while worker.is_alive():
        time.sleep(0.001)
        ticks += worker.is_alive()
    return ticks
