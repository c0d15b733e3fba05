"""Networks in numpy: layers compute what torch computes, and files give them back."""

import numpy as np
import pytest
import torch
from torch import nn

from agents.policies import networks
from agents.policies.networks import Dense, activate, layers_from_torch


def normal(*shape: int) -> np.ndarray:
    return np.random.default_rng(sum(shape)).standard_normal(shape)


def test_full_layers_compute_as_torchs_and_come_back_from_their_names() -> None:
    network, seen = nn.Sequential(nn.Linear(5, 4), nn.GELU(), nn.Linear(4, 2)), normal(3, 6, 5)
    layers = networks.layers(networks.arrays(layers_from_torch(network.parameters())))
    expected = network(torch.tensor(seen).float()).detach()
    np.testing.assert_allclose(networks.run(layers, "GELU", seen), expected, atol=1e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ["Sigmoid", "SiLU", "Softplus", "Mish", "ELU", "GELU"])
def test_nothing_is_too_far_off_for_an_activation(name: str) -> None:
    np.testing.assert_allclose(activate(name, np.array([-1e4])), 0.0 if name != "ELU" else -1.0, atol=1e-12)


def test_layers_of_another_kind_of_numbers_are_refused() -> None:
    arrays = networks.arrays((Dense(normal(2, 3), normal(2)),))
    assert networks.layers(arrays, np.float64)
    with pytest.raises(ValueError, match="float64"):
        networks.layers(arrays)
