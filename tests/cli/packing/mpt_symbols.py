# SPDX-License-Identifier: Apache-2.0
"""Reads the symbols of packed fields as docs/reference/packed_fields.md, "Symbols", says. Implements the range coder,
the contexts and the mixers with only integers."""

LOGISTIC = [22, 28, 36, 47, 60, 77, 98, 126, 162, 208, 267, 342, 439, 562, 720, 922, 1179, 1506, 1921, 2446, 3108, 3938,
            4971, 6249, 7812, 9702, 11955, 14595, 17625, 21025, 24743, 28693, 32768, 36843, 40793, 44511, 47911, 50941,
            53581, 55834, 57724, 59287, 60565, 61598, 62428, 63090, 63615, 64030, 64357, 64614, 64816, 64974, 65097,
            65194, 65269, 65328, 65374, 65410, 65438, 65459, 65476, 65489, 65500, 65508, 65514]


def squash(odds):
    i, part = divmod(min(max(odds, -2048), 2047) + 2048, 64)
    return LOGISTIC[i] + (LOGISTIC[i + 1] - LOGISTIC[i]) * part // 64


def stretch_table():
    table, odds = [], -2048
    for i in range(4096):
        while odds < 2047 and squash(odds) < i * 16 + 8:
            odds += 1
        table.append(odds)
    return table


STRETCH = stretch_table()


def quotient(a, b):
    """Divides and rounds towards zero. b must be > 0."""
    return a // b if a >= 0 else -(-a // b)


class SymbolDecoder:
    """Contexts and mixers are made at their first use."""

    def __init__(self, data):
        self.data, self.next, self.range, self.code = data, 0, 0xffffffff, 0
        self.contexts, self.mixers = {}, {}
        for _ in range(4):
            self.take_byte()

    def take_byte(self):
        byte = self.data[self.next] if self.next < len(self.data) else 0
        self.next += 1
        self.code = (self.code << 8 | byte) & 0xffffffff

    def symbol(self, probability):
        bound = (self.range >> 16) * probability
        bit = self.code < bound
        if bit:
            self.range = bound
        else:
            self.code -= bound
            self.range -= bound
        while self.range < 1 << 24:
            self.range <<= 8
            self.take_byte()
        return 1 if bit else 0

    def context(self, name):
        return self.contexts.setdefault(name, [32768, 32768, 0])

    @staticmethod
    def probability(context):
        return min(max((context[0] + context[1]) // 2, 32), 65504)

    @staticmethod
    def learn(context, bit):
        target = 65535 if bit else 0
        context[0] += quotient((target - context[0]) * 2, 2 * min(context[2], 20) + 3)
        context[1] += quotient((target - context[1]) * 2, 2 * min(context[2], 160) + 3)
        context[2] = min(context[2] + 1, 160)

    def bit(self, name):
        context = self.context(name)
        bit = self.symbol(self.probability(context))
        self.learn(context, bit)
        return bit

    def mixed(self, names, mixer):
        contexts = [self.context(name) for name in names]
        odds = [STRETCH[self.probability(context) // 16] for context in contexts]
        weights = self.mixers.setdefault(mixer, [26000] * 4)
        total = quotient(sum(w * x for w, x in zip(weights, odds)), 65536)
        probability = squash(total)
        bit = self.symbol(probability)
        error = (65535 if bit else 0) - probability
        for i, x in enumerate(odds):
            weights[i] = min(max(weights[i] + quotient(error * x, 1 << 15), -(1 << 15)), 1 << 19)
        for context in contexts:
            self.learn(context, bit)
        return bit

    def number(self, name):
        length = 0
        while length < 16 and self.bit((*name, length)):
            length += 1
        value = 1
        for _ in range(length):
            value = value << 1 | self.symbol(32768)
        return value - 1
