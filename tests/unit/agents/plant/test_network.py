"""The network: shapes, masks, symmetry, and its encoder against BERT."""

import pytest
import torch
from torch import Tensor

from plant_bench.agents.plant.config import SIZES, PlanTConfig, Size, SizeName
from plant_bench.agents.plant.network import Batch, PlanTNetwork
from plant_bench.agents.plant.transformer import Encoder, bert_parameters
from plant_bench.features.tokens import TokenKind, TokenSpec

TOKENS = 7


def network(**choices: object) -> PlanTNetwork:
    torch.manual_seed(0)
    return PlanTNetwork(PlanTConfig(**choices)).eval()  # pyright: ignore[reportArgumentType]


def batch_of(scenes: int = 3, tokens: int = TOKENS) -> Batch:
    torch.manual_seed(1)
    return Batch(
        5.0 * torch.randn(scenes, tokens, 6),
        torch.randint(1, 4, (scenes, tokens)).byte(),
        torch.arange(scenes).float() % 2,
        10.0 * torch.randn(scenes, 2),
        torch.full((scenes,), 4.0),
        torch.full((scenes,), 8.0),
    )


def padded(batch: Batch, more: int) -> Batch:
    scenes = len(batch.red)
    return batch._replace(
        attributes=torch.cat((batch.attributes, torch.randn(scenes, more, 6)), dim=1),
        kinds=torch.cat((batch.kinds, torch.zeros(scenes, more, dtype=torch.uint8)), dim=1),
    )


def test_outputs_have_the_expected_shapes() -> None:
    output = network()(batch_of())
    assert output.waypoints.shape == (3, 4, 2)
    expected = [(3, TOKENS, bins) for bins in (4, 128, 128, 32, 128, 128)]
    assert [tuple(logits.shape) for logits in output.futures] == expected


@torch.no_grad()
def test_padding_does_not_change_the_output() -> None:
    one, batch = network(), batch_of()
    alone, among = one(batch), one(padded(batch, 4))
    torch.testing.assert_close(among.waypoints, alone.waypoints, atol=1e-5, rtol=0)
    for some, more in zip(alone.futures, among.futures, strict=True):
        torch.testing.assert_close(more[:, :TOKENS], some, atol=1e-5, rtol=0)
    waypoints, _ = one.plan(batch)
    torch.testing.assert_close(waypoints, alone.waypoints, atol=1e-5, rtol=0)


@torch.no_grad()
def test_first_token_only_equals_the_full_encoding() -> None:
    encoder = Encoder(Size(2, 32, 4)).eval()
    embedded = torch.randn(3, TOKENS, 32)
    hidden, attention = encoder(embedded, explain=True)
    first, also = encoder(embedded, explain=True, first_only=True)
    assert first.shape == (3, 1, 32)
    torch.testing.assert_close(first, hidden[:, :1], atol=1e-6, rtol=0)
    torch.testing.assert_close(also, attention, atol=1e-6, rtol=0)


@torch.no_grad()
def test_network_plans_without_tokens() -> None:
    waypoints, attention = network().plan(batch_of(tokens=0), explain=True)
    assert waypoints.isfinite().all()
    assert attention is not None
    assert attention.shape == (3, 0)


@torch.no_grad()
def test_output_does_not_depend_on_the_token_order() -> None:
    one, batch, order = network(), batch_of(), torch.randperm(TOKENS)
    mixed = batch._replace(attributes=batch.attributes[:, order], kinds=batch.kinds[:, order])
    (here, seen), (there, also) = one.plan(batch, explain=True), one.plan(mixed, explain=True)
    torch.testing.assert_close(there, here, atol=1e-5, rtol=0)
    assert seen is not None
    assert also is not None
    torch.testing.assert_close(also, seen[:, order], atol=1e-5, rtol=0)


@torch.no_grad()
def test_attention_is_positive_and_sums_to_less_than_the_heads() -> None:
    one, batch = network(), batch_of()
    _, attention = one.plan(batch, explain=True)
    assert attention is not None
    size = one.config.encoder
    assert (attention > 0.0).all()
    assert (attention.sum(dim=1) < size.layers * size.heads).all()  # the rest is [CLS]'s own


@torch.no_grad()
def test_each_enabled_input_changes_the_plan() -> None:
    plain, told = network(), network(speed_input=True, limit_input=True)
    batch = batch_of()
    faster = batch._replace(speed=batch.speed + 1.0)
    withheld = batch._replace(speed=torch.full_like(batch.speed, torch.nan))
    other_limit = batch._replace(limit=batch.limit + 1.0)
    for changed in (faster, withheld, other_limit):
        assert torch.equal(plain.plan(changed)[0], plain.plan(batch)[0])
        assert not torch.equal(told.plan(changed)[0], told.plan(batch)[0])
    for changed in (
        batch._replace(red=1.0 - batch.red),
        batch._replace(target=batch.target + 1.0),
        batch._replace(kinds=torch.full_like(batch.kinds, TokenKind.ROUTE)),
    ):
        assert not torch.equal(plain.plan(changed)[0], plain.plan(batch)[0])


def test_bins_follow_the_reach() -> None:
    bins = PlanTConfig(tokens=TokenSpec(reach=50.0)).bins
    assert [(item.low, item.high) for item in bins[1:3]] == [(-50.0, 50.0)] * 2


@pytest.mark.parametrize(("name", "millions"), [("mini", 11.2), ("small", 28.8), ("medium", 41.4)])
def test_parameter_counts_equal_those_of_the_paper(name: SizeName, millions: float) -> None:
    assert round(bert_parameters(SIZES[name]) / 1e6, 1) == millions


@torch.no_grad()
def test_encoder_equals_bert() -> None:
    from transformers import BertConfig, BertModel

    size = Size(2, 32, 4)
    config = BertConfig(
        hidden_size=size.width,
        num_hidden_layers=size.layers,
        num_attention_heads=size.heads,
        intermediate_size=4 * size.width,
    )
    torch.manual_seed(0)
    bert, mine = BertModel(config).eval(), Encoder(size).eval()
    assert sum(weights.numel() for weights in bert.parameters()) == bert_parameters(size)
    mine.load_state_dict(_translated(bert.state_dict(), size))
    bert.embeddings.position_embeddings.weight.zero_()
    bert.embeddings.token_type_embeddings.weight.zero_()
    embedded = torch.randn(3, TOKENS, size.width)
    absent = torch.arange(TOKENS) >= torch.tensor([[TOKENS], [5], [2]])
    expected = bert(inputs_embeds=embedded, attention_mask=(~absent).long()).last_hidden_state
    hidden, _ = mine(embedded, absent)
    torch.testing.assert_close(hidden[~absent], expected[~absent], atol=1e-5, rtol=0)


def _translated(bert: dict[str, Tensor], size: Size) -> dict[str, Tensor]:
    """Return BERT's weights under the encoder's names; queries, keys and values in one matrix."""
    names = {
        "mix": "attention.output.dense",
        "attention_norm": "attention.output.LayerNorm",
        "widen": "intermediate.dense",
        "narrow": "output.dense",
        "norm": "output.LayerNorm",
    }
    state = {}
    for part in ("weight", "bias"):
        state[f"norm.{part}"] = bert[f"embeddings.LayerNorm.{part}"]
        for layer in range(size.layers):
            theirs, ours = f"encoder.layer.{layer}", f"layers.{layer}"
            for our_name, their_name in names.items():
                state[f"{ours}.{our_name}.{part}"] = bert[f"{theirs}.{their_name}.{part}"]
            parts = [
                bert[f"{theirs}.attention.self.{name}.{part}"] for name in ("query", "key", "value")
            ]
            state[f"{ours}.query_key_value.{part}"] = torch.cat(parts)
    return state
