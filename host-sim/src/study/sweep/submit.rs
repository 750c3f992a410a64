//! Files for engines that share a study's shards out to machines.
