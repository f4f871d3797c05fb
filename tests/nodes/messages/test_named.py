"""Values by the names in a message, and messages by their source."""

import numpy as np
from ddh_twin_py.nodes.messages.conversion import FREE_RUN, SOFT_SENSOR
from ddh_twin_py.nodes.messages.named import of_source, ordered
from rclpy.serialization import serialize_message

from ddh_msgs.msg import ResidualArray


def test_columns_follow_the_wanted_names():
    values = np.array([[1.0, 2.0], [3.0, 4.0]])
    np.testing.assert_array_equal(ordered(["b", "a"], ["a", "c", "b"], values), [[2.0, np.nan, 1.0], [4.0, np.nan, 3.0]])
    np.testing.assert_array_equal(ordered(["b", "a"], ("a", "c"), values, missing=0.0), [[2.0, 0.0], [4.0, 0.0]])
    np.testing.assert_array_equal(ordered(("a", "b"), ["a", "b"], values), values)


def test_messages_of_one_source_are_taken():
    free, soft, longer = (serialize_message(ResidualArray(source=source)) for source in (FREE_RUN, SOFT_SENSOR, f"{FREE_RUN}_2"))
    assert of_source([free, soft, longer, free], FREE_RUN) == [free, free]
