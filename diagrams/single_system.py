"""One system under test: the weight allocator alone, with its inputs fixed by hand."""

from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.scenario import Allocation
from aerodrake.systems.weight_allocator import WeightAllocator


def main() -> None:
    allocator = WeightAllocator(Allocation(), period=0.02)
    context = allocator.CreateDefaultContext()
    allocator.GetInputPort("d_g").FixValue(context, [1.0])
    for d_e, d_o in ((1.5, 0.0), (0.5, 0.0), (0.01, 0.02), (0.01, 0.2)):
        allocator.GetInputPort("distances").FixValue(context, [d_e, d_o])
        gamma, mode, w_q, w_m, w_d = allocator.GetOutputPort("weights").Eval(context)
        print(
            f"d_e {d_e:.2f} m, d_o {d_o:.2f} m: {Mode(int(mode)).label}, gamma {gamma:.3f}, "
            f"w_q {w_q:.0f}, w_m {w_m:.1f}, w_d {w_d:.2f}"
        )


if __name__ == "__main__":
    main()
