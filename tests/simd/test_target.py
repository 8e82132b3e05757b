import pytest
from llvmlite import binding

from flowabs_nodes.errors import CommandError
from flowabs_nodes.simd.target import kernel_path


@pytest.fixture
def processor(monkeypatch):
    """Set what the processor has, and what the environment says."""

    def setting(features=("avx2", "avx512f", "avx512dq"), **environment):
        for name in ("FLOWABS_SIMD", "NUMBA_CPU_FEATURES", "NUMBA_ENABLE_AVX"):
            monkeypatch.delenv(name, raising=False)
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        has = {"sse2": True, "avx512bw": False, **dict.fromkeys(features, True)}
        monkeypatch.setattr(binding, "get_host_cpu_features", lambda: has)

    return setting


@pytest.mark.parametrize("asked", ["", "auto", "avx512"])
def test_avx512_where_it_is(processor, asked):
    processor(FLOWABS_SIMD=asked)
    assert kernel_path() == "avx512"


@pytest.mark.parametrize("asked", ["", "auto", "portable"])
def test_portable_elsewhere(processor, asked):
    processor(["avx2", "avx512f"], FLOWABS_SIMD=asked)
    assert kernel_path() == "portable"


def test_portable_where_it_is_asked_for(processor):
    processor(FLOWABS_SIMD="portable")
    assert kernel_path() == "portable"


def test_what_numba_is_told_counts(processor):
    processor(NUMBA_CPU_FEATURES="+avx2,-avx512f,+avx512dq")
    assert kernel_path() == "portable"
    processor([], NUMBA_CPU_FEATURES="+avx512f,+avx512dq")
    assert kernel_path() == "avx512"
    processor(NUMBA_ENABLE_AVX="0")
    assert kernel_path() == "portable"


def test_another_word_is_an_error_that_names_the_right_ones(processor):
    processor(FLOWABS_SIMD="portabel")
    with pytest.raises(CommandError, match="auto, avx512, portable or nothing, found 'portabel'") as caught:
        kernel_path()
    assert caught.value.hint == "did you mean 'portable'?"


def test_avx512_cannot_be_asked_for_where_it_is_not(processor):
    processor([], FLOWABS_SIMD="avx512")
    with pytest.raises(CommandError, match="no AVX-512"):
        kernel_path()


@pytest.mark.parametrize(
    ("variable", "value"), [("NUMBA_NUM_THREADS", "0"), ("NUMBA_NUM_THREADS", "-2"), ("NUMBA_DISABLE_JIT", "1")]
)
def test_settings_of_numba_that_no_kernel_can_run_with_are_refused_by_name(monkeypatch, variable, value):
    monkeypatch.setenv(variable, value)
    with pytest.raises(CommandError, match=variable):
        kernel_path()


def test_a_generic_processor_has_no_avx512(monkeypatch):
    monkeypatch.delenv("FLOWABS_SIMD", raising=False)
    monkeypatch.delenv("NUMBA_CPU_FEATURES", raising=False)
    monkeypatch.setenv("NUMBA_CPU_NAME", "generic")
    assert kernel_path() == "portable"
