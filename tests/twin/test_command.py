"""The speed command between its samples."""

import numpy as np
from ddh_twin_py.twin.command import command_at


def test_samples_out_of_order_and_given_twice_say_what_they_say_in_order():
    time = np.array([0.0, 0.1, 0.3, 0.2, 0.25, 0.4, 0.4, 0.5])
    command = np.where(time < 0.2, 0.0, 100.0 * (time - 0.2))
    edges, once = np.linspace(0.0, 0.5, 21), np.array([0, 1, 3, 4, 2, 5, 7])
    np.testing.assert_array_equal(command_at(time, command, edges), command_at(time[once], command[once], edges))
