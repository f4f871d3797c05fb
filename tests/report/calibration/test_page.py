"""The residuals of a calibration's page: what scatters is drawn as it scatters, and said to be."""

import json
from types import SimpleNamespace

import numpy as np
from ddh_twin_py.report.calibration.page import _residuals

SAMPLES = 20_000


def specs(values, share, used):
    """Charts of one signal with noise of 1 V, as the page gets them."""
    time = 0.01 * np.arange(values.size)
    experiment = SimpleNamespace(signals={"voltage": SimpleNamespace(time=time, measured=values, noise=1.0, unit="V")}, used_until=used,
                                 held_from=used + 5.0, parameters=lambda rig: None,
                                 predict=lambda parameters, begin: {"voltage": np.zeros(values.size)})
    (chart,) = _residuals(experiment, SimpleNamespace(rig=None), share)
    markup = chart.html((0.0, time[-1]))
    return chart, json.loads(markup[markup.index('json">') + 6:markup.index("</script>")])


def test_noise_is_told_by_its_mean_and_its_ends_and_not_by_its_extremes_alone():
    noise = np.random.default_rng(1).normal(size=SAMPLES)
    noise[7000] = 11.0
    chart, spec = specs(noise, 0.25, 150.0)
    told = {line["label"]: line for line in spec["lines"]}
    assert list(told) == ["1.6 × sensor noise", "fitted part", "held out"]
    assert all("dots" not in line and line["band"] for line in told.values())
    parts = {trace.label: trace for trace in chart.traces[1:]}
    for trace, low, high in zip(parts.values(), (0.0, 155.0), (150.0, 200.0), strict=True):
        here = np.isfinite(trace.values)
        assert np.abs(trace.values[here]).max() < 0.9 and (chart.time[here] > low).all() and (chart.time[here] < high).all()
        assert (trace.ends[0][here] < trace.values[here]).all() and (trace.ends[1][here] > trace.values[here]).all()
    assert not np.isfinite(parts["fitted part"].values[np.isfinite(parts["held out"].values)]).any()
    assert np.nanmax(parts["fitted part"].ends[1]) == 11.0 == spec["y"][4][1]  # the peak stays, as the upper end


def test_few_samples_are_dots_each():
    chart, spec = specs(np.random.default_rng(1).normal(size=300), 0.0, 3.0)
    assert [line["label"] for line in spec["lines"] if line.get("dots")] == ["fitted part"]
    assert np.isfinite(chart.traces[1].values).sum() == 300
