"""Many telemetry messages at once into an open bag."""

from ddh_twin_py.bags.cdr import encode_stamped_floats
from ddh_twin_py.bags.qos import SENSOR_DATA


def write_rows(writer, topic, message_type, stamps_ns, values, log_times_ns=None):
    """Write messages of one telemetry type: stamps and log times int64[n] ns, values float64[n, m] as on the wire."""
    log_times = stamps_ns if log_times_ns is None else log_times_ns
    for log_time, message in zip(log_times.tolist(), encode_stamped_floats(stamps_ns, values, ""), strict=True):
        writer.write_raw(topic, message_type, SENSOR_DATA, log_time, message.data)
