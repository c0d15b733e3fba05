"""The cluster that the page on more than one machine says to copy is one that Ray understands."""

import yaml
from ray.autoscaler._private.util import prepare_config, validate_config

from agents.ground.places import SHIPPED


def test_ray_takes_the_cluster_to_copy() -> None:
    said = yaml.safe_load((SHIPPED / "docs" / "cluster.yaml").read_text())
    found = prepare_config(said)
    validate_config(found)
    assert found["provider"]["worker_ips"] == ["10.0.0.2", "10.0.0.3"]
    assert all("--autoscaling-config" not in line for line in found["worker_start_ray_commands"])
