"""The seal keeps the truth out of sight, in one piece, and with its own recordings."""

import json

import pytest

from exoid.measurement.bench.seal import HiddenTruth, SealError, Truth, open_seal, write_seal

TRUTH = Truth("standard leg", (1.0, 2.0), (HiddenTruth("stribeck", "knee", {"c": 2.5, "v_s": 0.1}),), 7)


@pytest.fixture
def sealed(tmp_path):
    recording = tmp_path / "run_0.csv"
    recording.write_text("t,q1,q2,tau1,tau2\n0,0,0,0,0\n")
    return write_seal(tmp_path / "run.seal", TRUTH, [recording]), recording


def test_a_seal_gives_back_the_truth(sealed):
    path, recording = sealed
    assert open_seal(path, [recording]).truth == TRUTH
    assert TRUTH.terms == ("stribeck:knee",)


def test_a_glance_at_the_seal_gives_nothing_away(sealed):
    text = sealed[0].read_text()
    assert not any(word in text for word in ("stribeck", "knee", "v_s", "2.5", "standard"))


def test_the_same_truth_seals_to_the_same_bytes(sealed, tmp_path):
    again = write_seal(tmp_path / "again.seal", TRUTH, [sealed[1]])
    assert again.read_bytes() == sealed[0].read_bytes()


def test_a_renamed_recording_still_belongs_an_altered_one_does_not(sealed):
    path, recording = sealed
    renamed = recording.rename(recording.with_name("other.csv"))
    assert open_seal(path, [renamed]).truth == TRUTH
    renamed.write_text("t,q1\n")
    with pytest.raises(SealError, match=r"other\.csv is not one of the recordings of this seal"):
        open_seal(path, [renamed])


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"kind": 1}', "\x00\xff", "[" * 100_000])
def test_what_is_no_seal_is_refused(tmp_path, text):
    path = tmp_path / "no.seal"
    path.write_text(text)
    with pytest.raises(SealError, match="not a seal of exoid, or it is damaged"):
        open_seal(path)


def test_an_altered_or_missing_seal_is_refused(sealed, tmp_path):
    document = json.loads(sealed[0].read_text())
    document["sha256"] = "0" * 64
    sealed[0].write_text(json.dumps(document))
    with pytest.raises(SealError, match="altered after it was written"):
        open_seal(sealed[0])
    with pytest.raises(SealError, match="cannot be read"):
        open_seal(tmp_path / "absent.seal")
    with pytest.raises(SealError, match="a recording cannot be read"):
        write_seal(tmp_path / "x.seal", TRUTH, [tmp_path / "absent.csv"])
