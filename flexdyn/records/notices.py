"""Warnings about a recording that is read."""


class RecordingWarning(UserWarning):
    r"""Something about a file was guessed, or the user should know it: encoding, decimal sign, gaps in time.

    Example:
        >>> import pathlib, warnings
        >>> rows = ["t;q.elbow;tau.elbow", "0,0;1,0;0,0", "0,1;1,1;0,0", "0,2;1,2;0,0"]
        >>> _ = pathlib.Path("log.csv").write_text("\n".join(rows))
        >>> with warnings.catch_warnings(record=True, action="always", category=fd.RecordingWarning) as told:
        ...     log = fd.read_recording("log.csv")
        >>> ["decimal comma" in str(each.message) for each in told if each.category is fd.RecordingWarning]
        [True]
    """
