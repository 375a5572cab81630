# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
#
# A bare machine as the README has it: its packages, then the two commands.
#   docker build -t pmwvc . && docker run --rm pmwvc
FROM debian:12
RUN apt-get update \
    && apt-get install -y build-essential python3-dev python3-venv git \
    && rm -rf /var/lib/apt/lists/*
COPY . /pmwvc
WORKDIR /pmwvc
RUN make setup
CMD ["make", "run"]
