"""PlanT's network: a transformer encoder over object tokens, and a GRU that decodes waypoints.

Sources: PlanT, section 3, equations 1 to 3; its public code for details that the paper leaves open
(the decoder's width). Unlike there, attributes are scaled to about 1 and padding is masked.
"""

import math
from typing import NamedTuple

import torch
from jaxtyping import Float, UInt8
from torch import Tensor, nn
from torch.nn import functional

from plant_bench.agent import PLAN_STEPS
from plant_bench.agents.plant.config import PlanTConfig
from plant_bench.agents.plant.transformer import DEVIATION, Encoder, initialise
from plant_bench.features.tokens import TokenKind, TokenSpec

DECODER_WIDTH = 64  # of the GRU, without the light's flag (PlanT, model.py)
SCALES = (10.0, 15.0, 15.0, math.pi, 2.0, 5.0)  # attributes are divided by these
CONFLICT_SCALES, MOTION_SCALES = (20.0, 3.0, 3.0, 3.0), (3.0, 0.5)
METRES, SPEED = 10.0, 10.0  # scales of points, and of the ego's speed and limit


class Batch(NamedTuple):
    """The network's inputs for a batch of scenes; see `plant_bench.features.network_inputs`.

    Attributes:
        attributes: The tokens' attributes.
        kinds: The tokens' `TokenKind`; padding is masked.
        red: 1 if the next light is red or yellow, else 0.
        target: A route point ahead in the ego frame, metres.
        speed: The ego's speed, m/s; used if the config says so, NaN where it is dropped.
        limit: The speed that meets all limits ahead, m/s; used if the config says so.
    """

    attributes: Float[Tensor, "batch tokens attributes"]
    kinds: UInt8[Tensor, "batch tokens"]
    red: Float[Tensor, " batch"]
    target: Float[Tensor, "batch 2"]
    speed: Float[Tensor, " batch"]
    limit: Float[Tensor, " batch"]


class Output(NamedTuple):
    """The network's output.

    Attributes:
        waypoints: Positions in the ego frame every 0.5 s, metres.
        futures: Logits of the bins half a second later, for each of the six attributes.
    """

    waypoints: Float[Tensor, "batch waypoints 2"]
    futures: tuple[Float[Tensor, "batch tokens bins"], ...]


def scales_of(spec: TokenSpec) -> tuple[float, ...]:
    """Return the scales that a token's attributes are divided by."""
    return SCALES + CONFLICT_SCALES * spec.conflicts + MOTION_SCALES * spec.motion


class PlanTNetwork(nn.Module):
    """PlanT's network: token embeddings, encoder, decoder and auxiliary heads.

    Args:
        config: Its size and inputs.
    """

    def __init__(self, config: PlanTConfig) -> None:
        super().__init__()
        width = config.encoder.width
        self.config = config
        self.scales = nn.Buffer(torch.tensor(scales_of(config.tokens)), persistent=False)
        self.project = nn.Linear(config.tokens.attributes, width)
        self.kinds = nn.Embedding(len(TokenKind), width)
        self.cls = nn.Parameter(torch.zeros(width))
        extras = 2 * config.speed_input + config.limit_input
        self.facts = nn.Linear(extras, width) if extras else None
        self.encoder = Encoder(config.encoder)
        self.futures = nn.ModuleList(nn.Linear(width, bins.count) for bins in config.bins)
        self.narrow = nn.Linear(width, DECODER_WIDTH)
        self.apply(initialise)
        nn.init.normal_(self.cls, std=DEVIATION)
        self.decoder = nn.GRUCell(4, DECODER_WIDTH + 1)
        self.step = nn.Linear(DECODER_WIDTH + 1, 2)

    def forward(self, batch: Batch) -> Output:
        """Return the output for a padded batch, for training."""
        hidden, _ = self.encode(batch, padded=True, explain=False)
        futures = tuple(head(hidden[:, 1:]) for head in self.futures)
        return Output(self.decode(hidden[:, 0], batch.red, batch.target), futures)

    def plan(
        self, batch: Batch, *, explain: bool = False
    ) -> tuple[Float[Tensor, "batch waypoints 2"], Float[Tensor, "batch tokens"] | None]:
        """Return the waypoints of scenes without padding and, with `explain`, the attention.

        That is the attention of [CLS] to each token, summed over layers and heads (PlanT, 4.3).
        """
        hidden, attention = self.encode(batch, padded=False, explain=explain, first_only=True)
        return self.decode(hidden[:, 0], batch.red, batch.target), attention

    def encode(
        self, batch: Batch, *, padded: bool, explain: bool, first_only: bool = False
    ) -> tuple[Float[Tensor, "batch hidden width"], Float[Tensor, "batch tokens"] | None]:
        """Return the encoder's output, [CLS] first, and the attention of [CLS] to the tokens.

        With `first_only`, the output has [CLS] alone.
        """
        kinds = batch.kinds.long()
        tokens = self.project(batch.attributes / self.scales) + self.kinds(kinds)
        cls = self.cls.expand(len(kinds), 1, -1)
        if self.facts is not None:
            cls = cls + self.facts(self._facts(batch))[:, None]
        absent = functional.pad(kinds == TokenKind.PADDING, (1, 0)) if padded else None
        hidden, attention = self.encoder(
            torch.cat((cls, tokens), 1), absent, explain=explain, first_only=first_only
        )
        return hidden, None if attention is None else attention[:, 1:]

    def decode(
        self,
        cls: Float[Tensor, "batch width"],
        red: Float[Tensor, " batch"],
        target: Float[Tensor, "batch 2"],
    ) -> Float[Tensor, "batch waypoints 2"]:
        """Decode the waypoints autoregressively, always in full precision."""
        with torch.autocast(cls.device.type, enabled=False):
            narrowed = functional.linear(cls.float(), self.narrow.weight, self.narrow.bias)
            hidden = torch.cat((narrowed, red[:, None]), dim=1)
            point, goal = torch.zeros_like(target), target / METRES
            points = []
            for _ in range(PLAN_STEPS):
                hidden = self.decoder(torch.cat((point, goal), dim=1), hidden)
                point = point + self.step(hidden)
                points.append(point)
            return torch.stack(points, dim=1) * METRES

    def _facts(self, batch: Batch) -> Float[Tensor, "batch facts"]:
        facts = []
        if self.config.speed_input:
            unknown = batch.speed.isnan()
            facts += [batch.speed.nan_to_num() / SPEED, 1.0 - unknown.float()]
        if self.config.limit_input:
            facts.append(batch.limit / SPEED)
        return torch.stack(facts, dim=1)
