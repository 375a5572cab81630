class Stateful:
    __slots__ = ()
