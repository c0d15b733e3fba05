"""Files of a line that a user may have: one that is there and cannot be read is an error, and not the usual values."""

from pathlib import Path

import pytest

from agents.dispatchers.settings import read_settings
from agents.ground.cli import UsageError
from pnt_gym.cells.line.chances import read_table
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError


@pytest.mark.parametrize("target", ["itself", "/", "/dev/zero", "nowhere"])
def test_a_link_that_leads_to_no_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, target: str) -> None:
    monkeypatch.chdir(tmp_path)
    config = LineConfig.load({"base": "single", "cell": {"belt": {"speed": 0.31}}, "throws": "flight"})
    table, rules = config.made_table(), Path("runs") / "line_rules.yaml"
    table.parent.mkdir(parents=True)
    for place in (table, rules):
        place.symlink_to(place.name if target == "itself" else target)
    with pytest.raises(UsageError, match="cannot read settings of rules"):
        read_settings()
    with pytest.raises(ConfigError, match="chances: cannot read"):
        read_table(config)
