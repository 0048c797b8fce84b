"""The section of actuation."""

from aerodrake.scenario import Actuation


def test_what_is_linear_remains():
    link = {"setpoint_latency_s": (0.005, 0.015), "setpoint_loss": 0.1}
    flaws = Actuation(
        rotor_dead_time_s=0.005,
        rotor_levels=100,
        thrust_scatter=0.05,
        sag=0.1,
        coulomb_n_m=(0.1, 0.2),
        viscous_n_m_s_rad=(0.1,),
        backlash_rad=(0.01,),
        flexibility_rad_n_m=(0.01,),
        **link,
    )
    assert flaws.linear == Actuation(
        rotor_dead_time_s=0.005,
        thrust_scatter=0.05,
        viscous_n_m_s_rad=(0.1,),
        flexibility_rad_n_m=(0.01,),
        setpoint_latency_s=(0.01, 0.01),
    )
    assert Actuation().linear == Actuation()
