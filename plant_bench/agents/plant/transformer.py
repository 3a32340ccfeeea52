"""PlanT's transformer: BERT's encoder (Devlin et al., 2019), batch first.

Outputs equal those of `transformers.BertModel`; a test copies its weights and compares.
"""

import math

import torch
from jaxtyping import Bool, Float
from torch import Tensor, nn
from torch.nn import functional

from plant_bench.agents.plant.config import Size

NORM_EPSILON = 1e-12  # BERT
DROPOUT = 0.1  # BERT
DEVIATION = 0.02  # standard deviation of initial weights, BERT
WIDENING = 4  # width of the feed-forward layer over the hidden width, BERT
BERT_WORDS, BERT_POSITIONS, BERT_TYPES = 30_522, 512, 2  # rows of BERT's tables


class Layer(nn.Module):
    """A transformer layer: attention and feed-forward, with residuals and post-normalisation."""

    def __init__(self, size: Size) -> None:
        super().__init__()
        width = size.width
        self.heads = size.heads
        self.query_key_value = nn.Linear(width, 3 * width)
        self.mix = nn.Linear(width, width)
        self.attention_norm = nn.LayerNorm(width, eps=NORM_EPSILON)
        self.widen = nn.Linear(width, WIDENING * width)
        self.narrow = nn.Linear(WIDENING * width, width)
        self.norm = nn.LayerNorm(width, eps=NORM_EPSILON)
        self.dropout = nn.Dropout(DROPOUT)

    def forward(
        self,
        hidden: Float[Tensor, "batch tokens width"],
        bias: Float[Tensor, "batch 1 1 tokens"] | None,
        *,
        explain: bool,
        first_only: bool = False,
    ) -> tuple[Float[Tensor, "batch some width"], Float[Tensor, "batch tokens"] | None]:
        """Return the new hidden states and, with `explain`, the first token's attention over heads.

        With `first_only`, return the first token's hidden state alone, which needs no queries and
        no feed-forward for the others.
        """
        query, key, value = self._projected(hidden, first_only=first_only)
        hidden = hidden[:, :1] if first_only else hidden
        batch, tokens, width = hidden.shape
        seen = _attention_of_first(query, key, bias) if explain else None
        mixed = functional.scaled_dot_product_attention(
            query, key, value, attn_mask=bias, dropout_p=DROPOUT if self.training else 0.0
        )
        mixed = mixed.transpose(1, 2).reshape(batch, tokens, width)
        hidden = self.attention_norm(hidden + self.dropout(self.mix(mixed)))
        widened = functional.gelu(self.widen(hidden))
        return self.norm(hidden + self.dropout(self.narrow(widened))), seen

    def _projected(self, hidden: Tensor, *, first_only: bool) -> tuple[Tensor, Tensor, Tensor]:
        """Return queries, keys and values, each (batch, heads, tokens, depth)."""
        batch, tokens, width = hidden.shape
        if not first_only:
            parts = self.query_key_value(hidden).view(batch, tokens, 3, self.heads, -1)
            query, key, value = parts.permute(2, 0, 3, 1, 4)
            return query, key, value
        weight, bias = self.query_key_value.weight, self.query_key_value.bias
        first = functional.linear(hidden[:, :1], weight[:width], bias[:width])
        others = functional.linear(hidden, weight[width:], bias[width:])
        key, value = others.view(batch, tokens, 2, self.heads, -1).permute(2, 0, 3, 1, 4)
        return first.view(batch, 1, self.heads, -1).transpose(1, 2), key, value


class Encoder(nn.Module):
    """Normalises embeddings and runs them through the layers.

    Args:
        size: Number of layers, width and heads.
    """

    def __init__(self, size: Size) -> None:
        super().__init__()
        self.norm = nn.LayerNorm(size.width, eps=NORM_EPSILON)
        self.dropout = nn.Dropout(DROPOUT)
        self.layers = nn.ModuleList(Layer(size) for _ in range(size.layers))

    def forward(
        self,
        embedded: Float[Tensor, "batch tokens width"],
        absent: Bool[Tensor, "batch tokens"] | None = None,
        *,
        explain: bool = False,
        first_only: bool = False,
    ) -> tuple[Float[Tensor, "batch some width"], Float[Tensor, "batch tokens"] | None]:
        """Return the last hidden states and the first token's attention, or None.

        Args:
            embedded: The token embeddings.
            absent: Mask of padding, which is not attended to; None for no padding.
            explain: Return the first token's attention, summed over layers and heads.
            first_only: Return the first token's last hidden state alone.
        """
        hidden = self.dropout(self.norm(embedded))
        bias = None
        if absent is not None:
            bias = torch.zeros_like(absent, dtype=hidden.dtype).masked_fill(absent, -math.inf)
            bias = bias[:, None, None, :]
        total = None
        last = len(self.layers) - 1
        for place, layer in enumerate(self.layers):
            first = first_only and place == last
            hidden, seen = layer(hidden, bias, explain=explain, first_only=first)
            if seen is not None:
                total = seen if total is None else total + seen
        return hidden, total


def initialise(module: nn.Module) -> None:
    """Initialise a module's own weights as in BERT, for `nn.Module.apply`."""
    if isinstance(module, nn.Linear | nn.Embedding):
        nn.init.normal_(module.weight, std=DEVIATION)
    if isinstance(module, nn.Linear) and module.bias is not None:
        nn.init.zeros_(module.bias)


def bert_parameters(size: Size) -> int:
    """Return the number of parameters of a BERT of this size, as counted in the paper.

    That is the encoder's, plus those that PlanT loads but never uses: the word, position and type
    embeddings and the pooler.

    >>> [bert_parameters(Size(*size)) for size in ((4, 256, 4), (4, 512, 8), (8, 512, 8))]
    [11170560, 28763648, 41373184]
    """
    used = sum(weights.numel() for weights in Encoder(size).parameters())
    tables = (BERT_WORDS + BERT_POSITIONS + BERT_TYPES) * size.width
    pooler = (size.width + 1) * size.width
    return used + tables + pooler


def _attention_of_first(query: Tensor, key: Tensor, bias: Tensor | None) -> Tensor:
    weights = query[:, :, :1] @ key.transpose(2, 3) / math.sqrt(query.shape[-1])
    if bias is not None:
        weights = weights + bias
    return weights.softmax(dim=-1).sum(dim=(1, 2))
